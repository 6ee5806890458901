uniform vec2 origin;         // window position of the image's first pixel

flat out int material;
flat out vec3 normal;
flat out vec3 tangent;
out vec3 point;
out vec2 texture_coordinate;
out vec4 around;

void main() {
    vec3 n = normalize(in_normal / in_scale);
    Projection projected = box_projection(n);
    material = in_identity.y;
    normal = in_rotation * n;
    tangent = in_rotation * projected.tangent;
    texture_coordinate = projected.tile;
    point = camera_position();
    Around light = light_around(point, normal);
    around = vec4(light.irradiance, dot(light.mirrored, LUMINANCE));
    gl_Position = clip_position(point, origin);
}
