"""Many items of work on the processes of one machine, or on Ray."""
