/* image/color.c: sRGB, OKLab, and the two colour maps.
 *
 * Both maps are polylines in OKLab walked at constant speed, so that equal steps of the number are
 * equal steps to the eye (as far as OKLab's Euclidean distance is that).
 *
 * Sequential: OKLab lightness rises from 0.16 to 0.95 while the hue turns from violet (290
 * degrees) over red and orange to yellow (105), with as much chroma as fits into the sRGB gamut,
 * smoothed. The 33 points were cut from that curve by equal chords of 0.0300.
 * Diverging: two straight lines from a light grey (lightness 0.95) to a blue (hue 260) and to a
 * red (hue 27) of lightness 0.45 and chroma 0.1797, the largest that both hues have in sRGB. */
#include "image/image.h"

#include <math.h>
#include <stddef.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

double srgb_from_linear(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

double linear_from_srgb(double encoded)
{
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

uint8_t srgb8_from_linear(float linear)
{
    if (!(linear > 0)) /* NaN too */
        return 0;
    if (linear >= 1)
        return 255;
    return (uint8_t)(srgb_from_linear(linear) * 255 + 0.5);
}

void linear_from_oklab(const double lab[3], double out_rgb[3])
{
    double l = lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2];
    double m = lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2];
    double s = lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2];
    l = l * l * l, m = m * m * m, s = s * s * s;
    out_rgb[0] = 4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s;
    out_rgb[1] = -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s;
    out_rgb[2] = -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s;
}

static const double SEQUENTIAL[][3] = {
    {0.16000, 0.02494, -0.06852}, {0.18503, 0.03778, -0.07904}, {0.20964, 0.05268, -0.08768},
    {0.23566, 0.06746, -0.09030}, {0.26185, 0.08215, -0.08946}, {0.28787, 0.09677, -0.08614},
    {0.31373, 0.11096, -0.08045}, {0.33940, 0.12441, -0.07258}, {0.36488, 0.13692, -0.06273},
    {0.39012, 0.14837, -0.05116}, {0.41510, 0.15869, -0.03807}, {0.43980, 0.16788, -0.02365},
    {0.46417, 0.17595, -0.00805}, {0.48817, 0.18292, 0.00861},  {0.51213, 0.18688, 0.02628},
    {0.53636, 0.18476, 0.04391},  {0.56058, 0.17948, 0.06087},  {0.58481, 0.17181, 0.07687},
    {0.60909, 0.16194, 0.09155},  {0.63341, 0.15008, 0.10458},  {0.65781, 0.13648, 0.11564},
    {0.68228, 0.12146, 0.12445},  {0.70685, 0.10537, 0.13077},  {0.73151, 0.08861, 0.13438},
    {0.75626, 0.07161, 0.13514},  {0.78108, 0.05485, 0.13295},  {0.80596, 0.03883, 0.12774},
    {0.83082, 0.02411, 0.11954},  {0.85557, 0.01124, 0.10842},  {0.88006, 0.00081, 0.09449},
    {0.90399, -0.00655, 0.07790}, {0.92683, -0.01022, 0.05874}, {0.95000, -0.01062, 0.03963},
};

/* The polyline through count points, each step of equal length, at t in [0,1]. */
static void walk(const double (*points)[3], size_t count, double t, double out_rgb[3])
{
    if (!(t > 0)) /* NaN too */
        t = 0;
    if (t > 1)
        t = 1;
    double x = t * (double)(count - 1);
    size_t i = (size_t)x;
    if (i > count - 2)
        i = count - 2;
    double f = x - (double)i, lab[3];
    for (int k = 0; k < 3; k++)
        lab[k] = points[i][k] + f * (points[i + 1][k] - points[i][k]);
    linear_from_oklab(lab, out_rgb);
    for (int k = 0; k < 3; k++)
        out_rgb[k] = fmin(fmax(out_rgb[k], 0), 1);
}

void pnb_colormap_sequential(double t, double out_rgb[3])
{
    walk(SEQUENTIAL, sizeof(SEQUENTIAL) / sizeof(SEQUENTIAL[0]), t, out_rgb);
}

void pnb_colormap_diverging(double t, double out_rgb[3])
{
    const double blue = 260 * M_PI / 180, red = 27 * M_PI / 180, chroma = 0.1797;
    const double points[3][3] = {{0.45, chroma * cos(blue), chroma * sin(blue)},
                                 {0.95, 0, 0},
                                 {0.45, chroma * cos(red), chroma * sin(red)}};
    walk(points, 3, t, out_rgb);
}
