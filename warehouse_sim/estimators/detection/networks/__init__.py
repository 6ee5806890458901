"""The detector's network: blocks, backbone and neck, head."""
