"""What use does to a pallet: its look and its boards change, its meaning does not."""
