"""README.md of a dataset: what it is, what is in it, how to make it again, what it may be used for, its limits."""
