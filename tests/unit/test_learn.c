/* Coherent rays go as pencils, or as others where pencils before have done worse, by the rules of every instruction set of this
 * build: one pencil that does badly among many that do well moves few rays, and where all do badly few are tried again. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "learn_probe.h"

#define PLACE 3072u /* rays of a place: all together are those of 640x480 pixels */

typedef void probe(uint32_t place, int any, const uint8_t worse[PLACES], uint32_t away[PLACES]);

/* The part of the rays that go as others, of the places where pencils do worse and of those where they do better. */
static void ask(probe *of, int any, const uint8_t worse[PLACES], double part[2])
{
    uint32_t away[PLACES], places[2] = {0};
    of(PLACE, any, worse, away);
    part[0] = part[1] = 0.0;
    for (uint32_t i = 0; i < PLACES; i++) {
        places[worse[i]]++;
        part[worse[i]] += (double)away[i] / PLACE;
    }
    for (int k = 0; k < 2; k++)
        part[k] = places[k] ? part[k] / places[k] : 0.0;
}

static void level(const char *isa, probe *of)
{
    for (int any = 0; any < 2; any++) {
        uint8_t none[PLACES] = {0}, all[PLACES], few[PLACES] = {0}, half[PLACES] = {0};
        double part[2];
        for (uint32_t i = 0; i < PLACES; i++) {
            all[i] = 1;
            half[i] = i >= PLACES / 4 && i < 3 * PLACES / 4;
            few[i] = i % 33 == 10; /* three places */
        }
        ask(of, any, none, part);
        assert_true(part[0] == 0.0);
        ask(of, any, all, part);
        if (part[1] < 0.9)
            fail_msg("%s: where pencils of %s hits do worse only %g of the rays go as others", isa, any ? "any" : "closest",
                     part[1]);
        ask(of, any, few, part);
        if (part[0] > 0.05)
            fail_msg("%s: where pencils of %s hits do worse at three places %g of the others' rays go with theirs", isa,
                     any ? "any" : "closest", part[0]);
        ask(of, any, half, part);
        if (part[1] < 0.8 || part[0] > 0.2)
            fail_msg("%s: where pencils of %s hits do worse in one half %g of its rays go as others, and %g of the other half's",
                     isa, any ? "any" : "closest", part[1], part[0]);
    }
}

static void test_levels(void **state)
{
    (void)state;
#define LEVEL(name, isa)                                                                                                         \
    if (rti_isa_runs(isa))                                                                                                       \
        level(#name, probe_learn_##name);
    RTI_ISA_EACH(LEVEL)
#undef LEVEL
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_levels)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
