/* Looks at every model under the including file's ISA, and the table of them. */
#include "sim/contacts/contact_column.h"
#include "sim/lanes/lanes_reference.h"
#include "sim/sample/contact_look.h"

#define MODEL_TEXT "sim/sample/contact_look_tmpl.h"
#include "sim/law/for_each_model.h"

#define MODEL(d, n, f)                                                                                                 \
    {                                                                                                                  \
        NAME__(contact_forces_at, ISA, d, n, f, 0), NAME__(contact_energies, ISA, d, n, f, 0)                          \
    }
#define LAW(name, NAME_)                                                                                               \
    {{MODEL(2, name, 0), MODEL(2, name, 1), MODEL(2, name, 2)},                                                        \
     {MODEL(3, name, 0), MODEL(3, name, 1), MODEL(3, name, 2), MODEL(3, name, 3)}},
#define TABLE__(isa) contact_looks_##isa
#define TABLE_(isa)  TABLE__(isa)

const struct contact_looks TABLE_(ISA)[LAW_COUNT][2][4] = {CONTACT_LAWS(LAW)};
