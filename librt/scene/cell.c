/* Handing the current snapshot to any number of readers beside one writer, without a lock in the reader's way.
 *
 * Left-right: a reader counts itself into the place that is current, looks again, and only then reads. A writer fills the other
 * place after its readers are gone, makes it current, and empties the first after its readers are gone. Readers stay for the few
 * instructions of a retain.
 */
#include "scene.h"

void rti_cell_init(rti_cell *cell)
{
    atomic_init(&cell->current, 0);
    atomic_init(&cell->readers[0], 0);
    atomic_init(&cell->readers[1], 0);
    cell->snapshot[0] = NULL;
    cell->snapshot[1] = NULL;
}

rti_snapshot *rti_cell_acquire(rti_cell *cell)
{
    for (;;) {
        unsigned i = atomic_load(&cell->current);
        rti_snapshot *s;
        atomic_fetch_add(&cell->readers[i], 1);
        if (atomic_load(&cell->current) != i) {
            atomic_fetch_sub(&cell->readers[i], 1);
            continue;
        }
        s = cell->snapshot[i];
        if (s)
            rti_snapshot_retain(s);
        atomic_fetch_sub(&cell->readers[i], 1);
        return s;
    }
}

static void wait_for_readers(rti_cell *cell, unsigned i)
{
    while (atomic_load(&cell->readers[i]) != 0)
        rti_sleep(0.0);
}

void rti_cell_replace(rti_cell *cell, rti_snapshot *snapshot)
{
    unsigned i = atomic_load(&cell->current);
    wait_for_readers(cell, 1 - i);
    cell->snapshot[1 - i] = snapshot;
    atomic_store(&cell->current, 1 - i);
    wait_for_readers(cell, i);
    rti_snapshot_release(cell->snapshot[i]);
    cell->snapshot[i] = NULL;
}
