"""The networks: ours and the paper's, their channels and their checkpoints."""
