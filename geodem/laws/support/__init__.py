"""Laws of supports in ground that yields: what a lining or a bolt answers to a stretch."""
