#include "sim/run/explain.h"

#include <math.h>
#include <string.h>

#include "sim/run/sample_source.h"

static size_t bytes_per_particle(const struct particles *p)
{
    bool frictional = p->n_rotations > 0;
    size_t real = p->single ? sizeof(float) : sizeof(double);
    size_t reals =
        4 * (size_t)p->dimension + 2 * (size_t)p->n_rotations + 3; /* x v a x_list, omega alpha, radius ... */
    size_t sums = (size_t)SUMS_BYTES(p->dimension, frictional, p->single);
    size_t record = RECORD_STRIDE(p->dimension, frictional, p->single) * sizeof(double);
    size_t columns = (size_t)(p->dimension + p->n_rotations) * real;
    /* and a rest of each */
    size_t views = p->single ? (size_t)(4 * p->dimension + 2 * p->n_rotations + frictional) * sizeof(float) : 0;
    return (reals + frictional) * sizeof(double) + record + sums + columns + views;
}

/* What the kernels read and write. */
static size_t bytes_per_candidate(const struct contact_list *list, int dimension)
{
    size_t real = list->model.single ? sizeof(float) : sizeof(double), reals = 1;
    for (int c = 0; c < HISTORY_COLUMNS; c++)
        reals += history_has(&list->model, c);
    return sizeof(uint32_t) + (list->model.single ? (1 + (size_t)dimension) * sizeof(float) : 0) + reals * real;
}

static void explain_contacts(FILE *out, const struct contact_list *list, int dimension)
{
    const char *last = "";
    fprintf(out, "modelled per candidate contact: force");
    for (int c = 0; c < HISTORY_COLUMNS; c++) {
        const char *name = history_field(c)->name;
        if (history_has(&list->model, c) && strcmp(name, last) != 0)
            fprintf(out, ", %s", last = name);
    }
    fprintf(out, "%s: %zu bytes\n", list->model.frictional ? "" : "; no tangential force",
            bytes_per_candidate(list, dimension));
}

static void explain_contact_time(FILE *out, const struct sample *sample)
{
    const double pi = 3.14159265358979323846;
    double lightest = sample->particles.mass[0];
    for (int i = 1; i < sample->particles.count; i++)
        lightest = sample->particles.mass[i] < lightest ? sample->particles.mass[i] : lightest;
    for (int s = 0; s < sample->scene->n_stages; s++) {
        struct contact_law_constants law =
            contact_law_constants_of(&sample->scene->stage[s].material, sample->pairs.model.normal);
        double reduced = 0.5 * lightest, eta = law.gamma_n / (2 * reduced);
        double omega2 = law.stiffness / reduced - eta * eta;
        fprintf(out, "  stage %d %-12s dt %.3g s, ", s, sample->scene->stage[s].name, sample->scene->stage[s].dt_s);
        if (omega2 > 0)
            fprintf(out, "shortest contact time %.3g s = %.0f steps\n", pi / sqrt(omega2),
                    pi / sqrt(omega2) / sample->scene->stage[s].dt_s);
        else
            fprintf(out, "contacts of the lightest particle are overdamped\n");
    }
}

enum status explain_scene(FILE *out, const struct scene *scene)
{
    struct sample *sample;
    char kernel_set[64];
    TRY(sample_from_scene(&sample, scene));
    sample_kernel_set(sample, kernel_set, sizeof kernel_set);
    const struct particles *p = &sample->particles;
    fprintf(out, "scene %s: %d particles, %d walls, %d stages\n", scene->name, p->count, sample->n_walls,
            (int)scene->n_stages);
    fprintf(out, "kernel  %s\n", kernel_set);
    fprintf(out, "modelled per particle: position, velocity, acceleration, force (%d components each)%s: %zu bytes\n",
            p->dimension, p->n_rotations ? ", rotation" : "; no rotation", bytes_per_particle(p));
    explain_contacts(out, &sample->pairs, p->dimension);
    fprintf(out, "starting box %g x %g", sample_box_length_m(sample, 0), sample_box_length_m(sample, 1));
    if (p->dimension == 3)
        fprintf(out, " x %g", sample_box_length_m(sample, 2));
    fprintf(out, " m, skin of the lists %g m%s\n", sample->verlet.skin,
            sample->verlet.skin_fixed > 0 ? "" : " to begin with (tuned while running)");
    explain_contact_time(out, sample);
    sample_free(sample);
    return STATUS_OK;
}
