"""A one-stage detector of the YOLOv5 architecture, written from its published facts."""
