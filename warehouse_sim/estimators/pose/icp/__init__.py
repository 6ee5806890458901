"""Point-to-plane refinement of a pose against the CAD surface."""
