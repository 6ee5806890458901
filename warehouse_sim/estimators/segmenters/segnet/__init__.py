"""Instance masks: a small SegNet looks into each detector's box and says which pixels are the object's."""
