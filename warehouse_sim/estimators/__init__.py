"""From images to poses in files: detectors, segmenters and pose estimators, one method a folder."""
