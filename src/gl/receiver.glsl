// The receiver of a pixel, from the frame (gl/frame.h).
uniform sampler2D frame_position; // world; w = 1, or 0: no receiver
uniform sampler2D frame_normal;   // unit, towards the eye; alpha: lift, metres

struct Receiver {
    bool valid;
    vec3 position; // on the surface
    vec3 normal;
    float lift;
    vec3 lifted; // what visibility is asked for
};

Receiver receiver_at(ivec2 pixel)
{
    vec4 p = texelFetch(frame_position, pixel, 0), n = texelFetch(frame_normal, pixel, 0);
    return Receiver(p.w > 0.5, p.xyz, n.xyz, n.w, p.xyz + n.w * n.xyz);
}

// The fragment's own.
Receiver receiver_here()
{
    return receiver_at(ivec2(gl_FragCoord.xy));
}
