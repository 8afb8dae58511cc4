"""Streets and open places."""
