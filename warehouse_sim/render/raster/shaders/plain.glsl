#define ADD_VARYINGS(n, projected)
#define ADD_LOOK(words)
#define DROP_EDGES(across, down, distance)
