"""What happens after failure: ground that has failed is handed over to discs, which run out and come to rest."""
