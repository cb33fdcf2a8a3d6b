"""The factor at which the ground fails: strength reduction and gravity increase."""
