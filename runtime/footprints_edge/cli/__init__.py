"""The commands. Typer and nothing else is imported before a command runs: help comes at once."""
