"""Networks of the shape of the methods that the paper's speed table compares with."""
