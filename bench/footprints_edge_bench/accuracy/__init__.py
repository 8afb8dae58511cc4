"""How accurate models and the paper's baselines are."""
