"""Cutting: a rigid tool moved through bonded rock or soil, and what it feels, does and leaves behind."""
