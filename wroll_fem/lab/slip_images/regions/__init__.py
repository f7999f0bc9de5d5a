"""Connected regions of a frame: light on the ground, threshold, labels and centroids."""
