"""Scores of detections: average precision of boxes, masks and KITTI results."""
