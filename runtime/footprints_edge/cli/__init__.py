"""The commands. Only Typer is imported before a command runs, so help appears at once."""
