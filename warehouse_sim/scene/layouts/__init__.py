"""Where things stand: each layout builds the fixed structure and says which slots can take a unit load."""
