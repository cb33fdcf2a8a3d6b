"""What is read off a state: the failed mass, its slip surface, energy and unbalanced force."""
