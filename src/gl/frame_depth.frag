// Window depth of the receivers: far plane at infinity, depth = 1 - near / distance.
uniform sampler2D frame_position;
uniform vec4 row_w; // of clip_from_world
uniform float near_w;

void main()
{
    vec4 p = texelFetch(frame_position, ivec2(gl_FragCoord.xy), 0);
    float w = dot(row_w.xyz, p.xyz) + row_w.w;
    gl_FragDepth = p.w > 0.5 && w > 0.0 ? clamp(1.0 - near_w / w, 0.0, 1.0) : 1.0;
}
