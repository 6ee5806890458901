"""Networks, losses, crops and training: the only room that imports torch."""
