"""Made scenes: rooms and streets with exact visible and hidden ground."""
