"""Problems with known answers, posed once and run by every code that can."""
