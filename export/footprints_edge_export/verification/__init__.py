"""Whether a file keeps the contract, and how far two of them are apart."""
