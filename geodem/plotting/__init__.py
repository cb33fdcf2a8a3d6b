"""Pictures, charts and the report, for people."""
