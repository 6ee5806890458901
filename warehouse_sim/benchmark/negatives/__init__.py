"""What must not be taken: look-alikes, blocked pallets and empty places, each before a camera, and who takes them."""
