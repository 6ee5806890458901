"""What stands on pallets: cartons, euro containers, drums, sacks, carriers of their own, and what secures them."""
