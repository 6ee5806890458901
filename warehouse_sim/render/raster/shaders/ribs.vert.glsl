// Needs box_projection.glsl.
flat out vec3 facet;         // unit normal in the part's frame
flat out vec3 grain;         // direction of the texture's u axis there
flat out vec3 eye;           // the camera in the part's frame
flat out mat3 to_camera;
flat out uint row;           // of the material
out vec3 place;              // in the part's frame (m)

void see_ribs(vec3 n, Projection projected) {
    facet = n;
    grain = projected.tangent;
    eye = -in_translation * in_rotation;
    to_camera = in_rotation;
    row = uint(in_identity.y);
    place = in_position * in_scale;
}

#define ADD_VARYINGS(n, projected) see_ribs(n, projected);
