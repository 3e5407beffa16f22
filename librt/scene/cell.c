/* Handing the current snapshot to any number of readers beside one writer, without a lock in the reader's way.
 *
 * Left-right: a reader counts itself into the place that is current, looks again, and only then reads. A writer fills the other
 * place after its readers are gone, makes it current, and empties the first after its readers are gone. Readers stay for the few
 * instructions of a retain, or for a few rays.
 */
#include "scene.h"

void rti_cell_init(rti_cell *cell)
{
    atomic_init(&cell->current, 0);
    for (uint32_t i = 0; i < RTI_SEATS; i++) {
        atomic_init(&cell->seats[i].readers[0], 0);
        atomic_init(&cell->seats[i].readers[1], 0);
    }
    cell->snapshot[0] = NULL;
    cell->snapshot[1] = NULL;
}

/* The calling thread's seat in every cell. */
static uint32_t my_seat(void)
{
    static _Thread_local uint32_t seat; /* 0: none yet */
    static atomic_uint next;
    if (seat == 0)
        seat = 1 + atomic_fetch_add_explicit(&next, 1, memory_order_relaxed) % RTI_SEATS;
    return seat - 1;
}

uint32_t rti_cell_enter(rti_cell *cell, rti_snapshot **snapshot)
{
    const uint32_t seat = my_seat();
    for (;;) {
        const uint32_t i = atomic_load(&cell->current);
        atomic_fetch_add(&cell->seats[seat].readers[i], 1);
        if (atomic_load(&cell->current) == i) {
            *snapshot = cell->snapshot[i];
            return 2 * seat + i;
        }
        atomic_fetch_sub(&cell->seats[seat].readers[i], 1);
    }
}

void rti_cell_leave(rti_cell *cell, uint32_t token)
{
    atomic_fetch_sub_explicit(&cell->seats[token / 2].readers[token % 2], 1, memory_order_release);
}

rti_snapshot *rti_cell_acquire(rti_cell *cell)
{
    rti_snapshot *s;
    const uint32_t token = rti_cell_enter(cell, &s);
    if (s)
        rti_snapshot_retain(s);
    rti_cell_leave(cell, token);
    return s;
}

static void wait_for_readers(rti_cell *cell, unsigned i)
{
    for (uint32_t k = 0; k < RTI_SEATS; k++)
        while (atomic_load(&cell->seats[k].readers[i]) != 0)
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
