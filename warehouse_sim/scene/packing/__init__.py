"""How pieces stand on a pallet: patterns of one layer, layers above each other, and mixed orders; never overlapping."""
