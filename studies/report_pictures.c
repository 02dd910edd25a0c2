/* Pictures of the first run of each cell: made in OUT/pictures, and put into the page. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "studies/files.h"
#include "studies/picture.h"
#include "studies/report.h"
#include "studies/run_frame.h"

static const char *const moment_names[MOMENTS] = {"start", "peak", "end"};
static const char *const kind_names[] = {"network", "particles", "spheres"};

struct shown {
    int run, stage, axis;
    double peak; /* strain; NaN: none */
};

/* What the analysis says of the stage. */
static bool shown_find(const struct results *results, const struct cell *cell, struct shown *shown)
{
    if (cell->n_runs == 0)
        return false;
    const json_t *analysis = results->analysis[cell->run[0]], *stage = json_object_get(analysis, "stage");
    const json_t *peak = json_object_get(json_object_get(analysis, "peak"), "eps_zz");
    const char *axis = json_string_value(json_object_get(stage, "axial"));
    *shown = (struct shown){cell->run[0], (int)json_integer_value(json_object_get(stage, "index")),
                            axis && axis[0] >= 'x' && axis[0] <= 'z' ? axis[0] - 'x' : 2, NAN};
    if (json_is_number(json_object_get(peak, "value")))
        shown->peak = json_number_value(json_object_get(peak, "value"));
    return true;
}

static enum status base_name(const struct report *report, const struct shown *shown, enum frame_moment moment,
                             enum picture_kind kind, char *base, size_t size)
{
    if (snprintf(base, size, "%s/pictures/%s-%s-%s", report->out, report->plan->run[shown->run].name,
                 moment_names[moment], kind_names[kind]) >= (int)size)
        return status_fail(STATUS_USAGE, "%.60s...: the path is too long", report->out);
    return STATUS_OK;
}

static enum status png_print(FILE *out, const char *base, const char *text, const char *width)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char path[4400];
    unsigned char bytes[3];
    size_t n;
    snprintf(path, sizeof path, "%s.png", base);
    FILE *file = fopen(path, "rb");
    if (!file)
        return status_fail(STATUS_IO, "%s: cannot be read", path);
    fprintf(out, "<img alt=\"%s\" width=\"%s\" src=\"data:image/png;base64,", text, width);
    while ((n = fread(bytes, 1, 3, file)) > 0) {
        uint32_t three = (uint32_t)bytes[0] << 16 | (n > 1 ? (uint32_t)bytes[1] << 8 : 0) | (n > 2 ? bytes[2] : 0);
        fputc(digits[three >> 18], out);
        fputc(digits[three >> 12 & 63], out);
        fputc(n > 1 ? digits[three >> 6 & 63] : '=', out);
        fputc(n > 2 ? digits[three & 63] : '=', out);
    }
    bool failed = ferror(file);
    (void)fclose(file);
    fputs("\">\n", out);
    return failed ? status_fail(STATUS_IO, "%s: cannot be read", path) : STATUS_OK;
}

static enum status picture_print(FILE *out, const struct report *report, const struct shown *shown,
                                 const struct frame *frame, double mean_n, enum frame_moment moment,
                                 enum picture_kind kind)
{
    char base[4300], text[200];
    TRY(base_name(report, shown, moment, kind, base, sizeof base));
    TRY(picture_draw(frame, kind, mean_n, base));
    if (kind == PICTURE_PARTICLES) /* as files alone: they would make the page large */
        return STATUS_OK;
    snprintf(text, sizeof text, "%s at %s, axial strain %.2f %%",
             kind == PICTURE_NETWORK ? "contact network: wider and darker lines are stronger forces, red ones attract"
                                     : "particles: the lighter the more force is on them",
             moment_names[moment], 100 * frame->strain);
    return png_print(out, base, text, kind == PICTURE_SPHERES ? "600" : "300");
}

/* The pictures of one run; forces on one scale, that of the start. */
static enum status run_print(FILE *out, const struct report *report, const struct shown *shown)
{
    char path[4400];
    double mean_n = 0;
    snprintf(path, sizeof path, "%s/runs/%s/run.h5", report->out, report->plan->run[shown->run].name);
    for (int moment = 0; moment < MOMENTS; moment++) {
        struct frame frame;
        if (moment == MOMENT_PEAK && !isfinite(shown->peak))
            continue;
        TRY(frame_read(&frame, path, shown->stage, shown->axis, shown->peak, (enum frame_moment)moment));
        if (moment == MOMENT_START)
            mean_n = picture_mean_force_n(&frame);
        enum status status = STATUS_OK;
        if (frame.dimension == 2) {
            status = picture_print(out, report, shown, &frame, mean_n, (enum frame_moment)moment, PICTURE_NETWORK);
            if (status == STATUS_OK)
                status =
                    picture_print(out, report, shown, &frame, mean_n, (enum frame_moment)moment, PICTURE_PARTICLES);
        } else if (picture_has_renderer()) {
            status = picture_print(out, report, shown, &frame, mean_n, (enum frame_moment)moment, PICTURE_SPHERES);
        } else {
            fputs("<p>Spheres are drawn by POV-Ray, which is not installed (apt-get install povray).</p>\n", out);
        }
        frame_free(&frame);
        TRY(status);
    }
    return STATUS_OK;
}

enum status report_pictures_print(FILE *out, const struct report *report, const struct results *results)
{
    char folder[4300];
    TRY(files_join(folder, sizeof folder, report->out, "pictures"));
    TRY(files_make_folder(folder));
    fputs(
        "<h2 id=\"pictures\">Pictures</h2>\n<p>The first sample of each cell at the start of the test, at the frame "
        "nearest to the peak, and at the end. Contacts: lines between the particles, the wider and darker the stronger "
        "the normal force, red where they attract; the scale ends at four times the mean force at the start. "
        "Particles: "
        "by the sum of the normal forces on them, dark is none. Files: pictures/.</p>\n",
        out);
    for (int c = 0; c < results->n_cells; c++) {
        struct shown shown;
        char text[1024];
        if (!shown_find(results, &results->cell[c], &shown))
            continue;
        cell_text(report->study, &results->cell[c], NULL, NULL, text, sizeof text);
        fputs("<details><summary>", out);
        report_text_print(out, text);
        fputs("</summary>\n", out);
        TRY(run_print(out, report, &shown));
        fputs("</details>\n", out);
    }
    return STATUS_OK;
}
