"""What must hold before a version is given away, each as one command."""
