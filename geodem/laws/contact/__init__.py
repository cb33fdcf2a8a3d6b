"""Laws of particles that touch, one file each."""
