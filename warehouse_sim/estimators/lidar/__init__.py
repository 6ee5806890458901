"""From a LiDAR's sweep to the points of single objects: depth images, clusters, a fixed number of points."""
