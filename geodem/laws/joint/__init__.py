"""Laws of joints, one file each."""
