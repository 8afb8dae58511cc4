"""Where things stand: floor plans, rooms, streets, skies."""
