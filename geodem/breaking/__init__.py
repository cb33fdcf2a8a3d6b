"""Ground that breaks: bonded particles of a body with what holds, cuts and reinforces them, and excavations in them."""
