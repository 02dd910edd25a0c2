#include "studies/picture.h"

#include <cairo-svg.h>
#include <cairo.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "studies/files.h"
#include "studies/process.h"

enum { WIDTH = 360, MARGIN = 6 };

/* From dark blue by green to yellow (viridis, at five places); 0 <= t <= 1. */
static void colour_at(double t, double rgb[3])
{
    static const double place[5][3] = {{0.267, 0.005, 0.329},
                                       {0.229, 0.322, 0.546},
                                       {0.128, 0.567, 0.551},
                                       {0.369, 0.789, 0.383},
                                       {0.993, 0.906, 0.144}};
    double s = 4 * fmin(fmax(t, 0), 1);
    int k = s >= 4 ? 3 : (int)s;
    for (int c = 0; c < 3; c++)
        rgb[c] = place[k][c] + (s - k) * (place[k + 1][c] - place[k][c]);
}

double picture_mean_force_n(const struct frame *frame)
{
    double sum = 0;
    for (int c = 0; c < frame->n_contacts; c++)
        sum += fabs(frame->contact[c].force_n);
    return frame->n_contacts > 0 ? sum / frame->n_contacts : 0;
}

bool picture_has_renderer(void)
{
    return process_exists("povray");
}

/* --- 2D ---------------------------------------------------------------------------------------------------------- */

static double height_of(const struct frame *frame)
{
    return (WIDTH - 2 * MARGIN) * (frame->upper_m[2] - frame->lower_m[2]) / (frame->upper_m[0] - frame->lower_m[0]) +
           2 * MARGIN;
}

/* x to the right, z upwards, in metres. */
static void space_set(cairo_t *cairo, const struct frame *frame)
{
    double scale = (WIDTH - 2 * MARGIN) / (frame->upper_m[0] - frame->lower_m[0]);
    cairo_set_source_rgb(cairo, 1, 1, 1);
    cairo_paint(cairo);
    cairo_translate(cairo, MARGIN, height_of(frame) - MARGIN);
    cairo_scale(cairo, scale, -scale);
    cairo_translate(cairo, -frame->lower_m[0], -frame->lower_m[2]);
}

static void box_draw(cairo_t *cairo, const struct frame *frame, double line)
{
    cairo_set_source_rgb(cairo, 0, 0, 0);
    cairo_set_line_width(cairo, line);
    cairo_rectangle(cairo, frame->lower_m[0], frame->lower_m[2], frame->upper_m[0] - frame->lower_m[0],
                    frame->upper_m[2] - frame->lower_m[2]);
    cairo_stroke(cairo);
}

static void contact_draw(cairo_t *cairo, const struct frame *frame, const struct frame_contact *contact, double mean_n,
                         double radius)
{
    const double *from = frame->position_m + 3 * contact->i;
    double strength = mean_n > 0 ? fmin(fabs(contact->force_n) / mean_n, 4) / 4 : 0, grey = 0.85 * (1 - strength);
    double to[2] = {from[0] - frame->radius_m[contact->i] * contact->normal[0],
                    from[2] - frame->radius_m[contact->i] * contact->normal[2]};
    if (contact->j >= 0) {
        to[0] = frame->position_m[3 * contact->j];
        to[1] = frame->position_m[3 * contact->j + 2];
    }
    if (contact->force_n < 0)
        cairo_set_source_rgb(cairo, 0.85, grey, grey);
    else
        cairo_set_source_rgb(cairo, grey, grey, grey);
    cairo_set_line_width(cairo, radius * (0.06 + 0.9 * strength));
    cairo_move_to(cairo, from[0], from[2]);
    cairo_line_to(cairo, to[0], to[1]);
    cairo_stroke(cairo);
}

static void particle_draw(cairo_t *cairo, const struct frame *frame, int k, double mean_n)
{
    double rgb[3];
    /* eight contacts of the mean force: the middle of the scale */
    colour_at(mean_n > 0 ? frame->force_n[k] / (16 * mean_n) : 0, rgb);
    cairo_set_source_rgb(cairo, rgb[0], rgb[1], rgb[2]);
    cairo_arc(cairo, frame->position_m[3 * k], frame->position_m[3 * k + 2], frame->radius_m[k], 0, 2 * M_PI);
    cairo_fill(cairo);
}

static void flat_draw(cairo_t *cairo, const struct frame *frame, enum picture_kind kind, double mean_n)
{
    double radius = 0;
    for (int k = 0; k < frame->n_particles; k++)
        radius += frame->radius_m[k] / frame->n_particles;
    space_set(cairo, frame);
    box_draw(cairo, frame, 0.3 * radius);
    if (kind == PICTURE_PARTICLES)
        for (int k = 0; k < frame->n_particles; k++)
            particle_draw(cairo, frame, k, mean_n);
    cairo_set_line_cap(cairo, CAIRO_LINE_CAP_ROUND);
    if (kind == PICTURE_NETWORK)
        for (int c = 0; c < frame->n_contacts; c++)
            contact_draw(cairo, frame, &frame->contact[c], mean_n, radius);
}

static enum status drawn(cairo_t *cairo, cairo_surface_t *surface, const char *path, bool png)
{
    cairo_status_t failed = cairo_status(cairo);
    if (failed == CAIRO_STATUS_SUCCESS && png)
        failed = cairo_surface_write_to_png(surface, path);
    cairo_destroy(cairo);
    cairo_surface_finish(surface);
    if (failed == CAIRO_STATUS_SUCCESS)
        failed = cairo_surface_status(surface);
    cairo_surface_destroy(surface);
    if (failed == CAIRO_STATUS_SUCCESS)
        return STATUS_OK;
    return status_fail(STATUS_IO, "%s: %s", path, cairo_status_to_string(failed));
}

static enum status flat_write(const struct frame *frame, enum picture_kind kind, double mean_n, const char *base)
{
    char path[4400];
    double height = height_of(frame);
    TRY(snprintf(path, sizeof path, "%s.svg", base) < (int)sizeof path ? STATUS_OK : status_fail(STATUS_USAGE, "path"));
    cairo_surface_t *surface = cairo_svg_surface_create(path, WIDTH, height);
    cairo_t *cairo = cairo_create(surface);
    flat_draw(cairo, frame, kind, mean_n);
    TRY(drawn(cairo, surface, path, false));
    snprintf(path, sizeof path, "%s.png", base);
    surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, WIDTH, (int)ceil(height));
    cairo = cairo_create(surface);
    flat_draw(cairo, frame, kind, mean_n);
    return drawn(cairo, surface, path, true);
}

/* --- 3D ---------------------------------------------------------------------------------------------------------- */

static void pov_print(FILE *out, const struct frame *frame, double mean_n)
{
    double middle[3], size = 0;
    for (int d = 0; d < 3; d++) {
        middle[d] = (frame->lower_m[d] + frame->upper_m[d]) / 2;
        size = fmax(size, frame->upper_m[d] - frame->lower_m[d]);
    }
    fprintf(out,
            "#version 3.7;\nglobal_settings { assumed_gamma 1 }\nbackground { color rgb 1 }\n"
            "camera { location <%.6g, %.6g, %.6g> look_at <%.6g, %.6g, %.6g> sky z right x*image_width/image_height "
            "angle 35 }\n"
            "light_source { <%.6g, %.6g, %.6g> color rgb 0.9 }\nlight_source { <%.6g, %.6g, %.6g> color rgb 0.4 "
            "shadowless }\n",
            middle[0] + 1.6 * size, middle[1] - 2.4 * size, middle[2] + 1.3 * size, middle[0], middle[1], middle[2],
            middle[0] + size, middle[1] - 4 * size, middle[2] + 4 * size, middle[0] + 4 * size, middle[1] - size,
            middle[2] + size);
    for (int k = 0; k < frame->n_particles; k++) {
        const double *x = frame->position_m + 3 * k;
        double rgb[3];
        colour_at(mean_n > 0 ? frame->force_n[k] / (12 * mean_n) : 0, rgb); /* six contacts in the middle */
        fprintf(
            out,
            "sphere { <%.8g, %.8g, %.8g>, %.8g pigment { color srgb <%.3f, %.3f, %.3f> } finish { ambient 0.2 diffuse "
            "0.8 specular 0.2 } }\n",
            x[0], x[1], x[2], frame->radius_m[k], rgb[0], rgb[1], rgb[2]);
    }
}

static enum status spheres_write(const struct frame *frame, double mean_n, const char *base)
{
    char path[4400], input[4500], output[4500], log[4500], *text = NULL;
    size_t size = 0;
    int code;
    FILE *out = open_memstream(&text, &size);
    if (!out)
        return status_fail(STATUS_NO_MEMORY, "out of memory");
    pov_print(out, frame, mean_n);
    enum status status = fclose(out) == 0 ? STATUS_OK : status_fail(STATUS_NO_MEMORY, "out of memory");
    snprintf(path, sizeof path, "%s.pov", base);
    if (status == STATUS_OK)
        status = files_write(path, text);
    free(text);
    TRY(status);
    snprintf(input, sizeof input, "+I%s", path);
    snprintf(output, sizeof output, "+O%s.png", base);
    snprintf(log, sizeof log, "%s.log", base);
    const char *const argv[] = {"povray", "-D", "+W960", "+H720", "+A0.2", input, output, NULL};
    TRY(process_run(argv, NULL, log, &code));
    return code == 0 ? STATUS_OK : status_fail(STATUS_IO, "povray failed; see %s", log);
}

enum status picture_draw(const struct frame *frame, enum picture_kind kind, double mean_n, const char *base)
{
    if (strlen(base) > 4300)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", base);
    return kind == PICTURE_SPHERES ? spheres_write(frame, mean_n, base) : flat_write(frame, kind, mean_n, base);
}
