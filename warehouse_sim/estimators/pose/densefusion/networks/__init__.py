"""Parts of the DenseFusion family and their composition."""
