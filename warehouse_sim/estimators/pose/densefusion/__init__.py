"""The DenseFusion family: networks, crops, losses, its training, calibration and export."""
