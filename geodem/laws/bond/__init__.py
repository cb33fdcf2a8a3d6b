"""Laws of particles that are bonded, one file each."""
