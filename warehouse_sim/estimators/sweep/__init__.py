"""LiDAR sweeps without a camera: the range image of a whole turn, a detector in it, poses of what it finds."""
