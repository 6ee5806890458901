// Pictures are laid once over the faces that look along the part's thinnest axis, upright along its z, or along its y
// where it lies; right is as seen from outside.
in vec4 in_picture;          // least place along the picture's two axes (m), and tiles a metre along them

flat out float layer;        // of the picture, below 0 on other faces
out vec2 picture_coordinate;

void lay_picture(vec3 n) {
    int facing = in_identity.w, up = facing == 2 ? 1 : 2, across = 3 - facing - up;
    vec3 metres = in_position * in_scale;
    vec2 at = (vec2(metres[across], metres[up]) - in_picture.xy) * in_picture.zw;
    bool mirrored = (n[facing] < 0.0) != (facing == 1);
    picture_coordinate = vec2(mirrored ? 1.0 - at.x : at.x, 1.0 - at.y);
    layer = abs(n[facing]) > 0.7 ? texelFetch(materials, ivec2(2, in_identity.y), 0).z : -1.0;
}

#define ADD_VARYINGS(n, projected) lay_picture(n);
