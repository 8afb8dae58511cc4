"""What stands along streets."""
