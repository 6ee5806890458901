"""The detector of objects in whole LiDAR sweeps: range images of whole turns, boxes and points in them."""
