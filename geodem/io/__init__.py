"""Files that a run leaves behind; each is written whole or not at all."""
