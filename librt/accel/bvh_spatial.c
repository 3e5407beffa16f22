/* Spatial splits (Stich, Friedrich, Dietrich 2009): a plane cuts the boxes of the references that it meets, so a long triangle
 * stands on both sides with a smaller box on each.
 *
 * No hit is lost. A piece's box holds the triangle's part on its side of the plane, cut to the box that the reference had, so the
 * pieces of a triangle always cover it. The points where edges cross the plane are rounded in float, by at most 8 roundings of a
 * coordinate; edges are those of the triangle itself, so the error does not add up from cut to cut, and RTK_GROW leaves 64
 * (ray.h, theory point 3).
 */
#include "bvh_build.h"

static int32_t bin_of(float x, float base, float scale, float last)
{
    return (int32_t)rtk_min(rtk_max((x - base) * scale, 0.0f), last);
}

/* The same on three axes; on one whose scale is 0, the first bin. */
static void bins_of(const rti_bvh_split *s, rti_f4 x, float last, int32_t out[4])
{
    rti_bvh_bins_of((rti_f4_xyz(x) - s->space_base) * s->space_scale, last, out);
}

static rti_bvh_box meet(rti_bvh_box a, rti_bvh_box b)
{
    rti_bvh_box r = {rti_f4_max(a.lo, b.lo), rti_f4_min(a.hi, b.hi)};
    return r;
}

static bool is_box(rti_bvh_box b)
{
    return rti_f4_below(b.lo, b.hi);
}

static void add_point(rti_bvh_box *b, rti_f4 p)
{
    rti_bvh_box point = {p, p};
    rti_bvh_extend(b, point);
}

static const rti_i4 along[3] = {{-1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}};

/* The two halves of a box at pos, which lies in it. */
static inline void cut_box(rti_bvh_box box, uint32_t axis, float pos, rti_bvh_box out[2])
{
    const rti_f4 plane = rti_f4_set(pos);
    out[0].lo = box.lo;
    out[0].hi = rti_f4_pick(along[axis], plane, box.hi);
    out[1].lo = rti_f4_pick(along[axis], plane, box.lo);
    out[1].hi = box.hi;
}

/* Boxes of the triangle's two parts. */
static void cut_triangle(const rtk_tri *tri, uint32_t axis, float pos, rti_bvh_box out[2])
{
    const float *v[3] = {tri->v0, tri->v1, tri->v2};
    out[0] = out[1] = rti_bvh_nothing();
    for (int i = 0; i < 3; i++) {
        const float *a = v[i], *b = v[i == 2 ? 0 : i + 1];
        /* what follows a corner is in the record, too */
        rti_f4 from = rti_f4_xyz(rti_f4_load(a)), to = rti_f4_xyz(rti_f4_load(b));
        if (a[axis] <= pos)
            add_point(&out[0], from);
        if (a[axis] >= pos)
            add_point(&out[1], from);
        if ((a[axis] < pos && b[axis] > pos) || (a[axis] > pos && b[axis] < pos)) {
            float t = (pos - a[axis]) / (b[axis] - a[axis]);
            rti_f4 p = from + (to - from) * t;
            add_point(&out[0], p);
            add_point(&out[1], p);
        }
    }
}

static void cut(const rti_bvh *t, uint32_t prim, rti_bvh_box box, uint32_t axis, float pos, rti_bvh_box out[2])
{
    rti_bvh_box half[2];
    float lo[4], hi[4];
    rti_f4_store(lo, box.lo);
    rti_f4_store(hi, box.hi);
    pos = rtk_min(rtk_max(pos, lo[axis]), hi[axis]);
    cut_box(box, axis, pos, half);
    out[0] = half[0];
    out[1] = half[1];
    if (prim >= t->b->in->tri_count)
        return;
    cut_triangle(&t->b->in->tris[prim], axis, pos, out);
    for (int i = 0; i < 2; i++) {
        out[i] = meet(out[i], half[i]);
        if (!is_box(
                out[i])) /* the part lies outside of what was left of the box before: by its rounding alone, or it is nothing */
            out[i] = half[i];
    }
}

bool rti_bvh_spatial_begin(const rti_bvh *t, const rti_bvh_range *range, rti_bvh_split *s)
{
    float lo[4], hi[4], scale[4] = {0};
    rti_bvh_box both = meet(s->left, s->right);
    s->spatial = false;
    s->space_bins = range->count < 64 ? 8 : RTI_BVH_BINS;
    /* Worth it only where the children of the best object split share space (Stich 2009, 4.1), three tenths of the parent's, and
     * there is room. With their 1.0e-5 builds take 1.25 times as long, and trees are larger, but no better. With a tenth, splits
     * cost batches .97 for the leaves that they add, and bring one ray a call 1.01. */
    if (range->count < 8 || range->room_end - range->room_begin <= range->count || (s->axis < 3 && !is_box(both)) ||
        (s->axis < 3 &&
         !(rti_bvh_area(t, both) > 1.0e-4f * t->root_area && rti_bvh_area(t, both) > 0.3f * rti_bvh_area(t, range->box))))
        return false;
    rti_f4_store(lo, range->box.lo);
    rti_f4_store(hi, range->box.hi);
    for (int a = 0; a < 3; a++) {
        float by = 0.9999f * (float)s->space_bins / (hi[a] - lo[a]);
        scale[a] = hi[a] - lo[a] > t->thinnest && by <= 1.0e36f ? by : 0.0f;
    }
    s->space_base = rti_f4_xyz(range->box.lo);
    s->space_scale = rti_f4_load(scale);
    for (int a = 0; a < 3; a++)
        for (uint32_t k = 0; k < s->space_bins; k++)
            s->planes[a][k] = scale[a] > 0.0f ? lo[a] + (float)k / scale[a] : lo[a];
    return true;
}

static inline void slice_box(const rti_bvh_split *s, rti_bvh_box box, uint32_t axis, int32_t first, int32_t end,
                             rti_bvh_box *bins)
{
    rti_bvh_box half[2];
    for (int32_t k = first; k < end; k++) {
        cut_box(box, axis, s->planes[axis][k + 1], half);
        rti_bvh_extend(&bins[k], half[0]);
        box = half[1];
    }
    rti_bvh_extend(&bins[end], box);
}

/* A triangle's corners in order along an axis, and the ways between them. */
typedef struct ladder {
    float at[3], by[3]; /* by: 1 / length along the axis; of the ways from 0 to 1, 1 to 2, 0 to 2 */
    rti_f4 corner[3], way[3];
} ladder;

/* Which corner is lowest, and so on, by whether 1 is below 0, 2 below 1, 2 below 0: branches could not be foreseen. */
static const uint8_t orders[8][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1}, {0, 1, 2}, {0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

static inline ladder ladder_of(const rtk_tri *tri, uint32_t axis)
{
    const float *v[3] = {tri->v0, tri->v1, tri->v2};
    const float x[3] = {v[0][axis], v[1][axis], v[2][axis]};
    const uint8_t *order = orders[(x[1] < x[0] ? 1u : 0u) | (x[2] < x[1] ? 2u : 0u) | (x[2] < x[0] ? 4u : 0u)];
    ladder l;
    for (int i = 0; i < 3; i++) {
        l.at[i] = v[order[i]][axis];
        l.corner[i] = rti_f4_xyz(rti_f4_load(v[order[i]])); /* what follows a corner is in the record, too */
    }
    for (int i = 0; i < 3; i++) {
        const int from = i == 1, to = i == 0 ? 1 : 2;
        l.way[i] = l.corner[to] - l.corner[from];
        l.by[i] = 1.0f / (l.at[to] - l.at[from]);
    }
    return l;
}

/* The point of a way where a plane meets it; an end of it where none does. */
static inline rti_f4 at_plane(const ladder *l, int from, int way, float plane)
{
    const float t = rtk_min(rtk_max((plane - l->at[from]) * l->by[way], 0.0f), 1.0f);
    return l->corner[from] + l->way[way] * rti_f4_set(t);
}

/* Around what a plane cuts out of the triangle: points of two ways, of which the longest is always one. */
static inline rti_bvh_box rung(const ladder *l, float plane)
{
    const int upper = plane > l->at[1];
    const rti_f4 p = at_plane(l, 0, 2, plane), q = at_plane(l, upper, upper, plane);
    return (rti_bvh_box){rti_f4_min(p, q), rti_f4_max(p, q)};
}

/* The middle corner joins where mask is all ones. */
static inline void add_middle(rti_bvh_box *part, const ladder *l, rti_i4 mask)
{
    part->lo = rti_f4_min(rti_f4_pick(mask, l->corner[1], rti_f4_set(RTK_INF)), part->lo);
    part->hi = rti_f4_max(rti_f4_pick(mask, l->corner[1], rti_f4_set(-RTK_INF)), part->hi);
}

static inline void put_part(rti_bvh_box part, rti_bvh_box box, rti_bvh_box *bin)
{
    part = meet(part, box);
    if (is_box(part))
        rti_bvh_extend(bin, part);
}

/* The triangle's parts between the planes, inside the box: the middle corner falls into one bin, on a plane into that below, and
 * what a plane cuts out is in both its bins. Only costs come of these boxes, so their rounding does not matter. */
static inline void slice_triangle(const rti_bvh_split *s, const rtk_tri *tri, const rti_ref *ref, uint32_t axis, int32_t first,
                                  int32_t end, rti_bvh_box *bins)
{
    const ladder l = ladder_of(tri, axis);
    const rti_bvh_box box = rti_bvh_ref_box(ref), low = {l.corner[0], l.corner[0]}, high = {l.corner[2], l.corner[2]};
    const float lo = ref->lo[axis], hi = ref->hi[axis];
    rti_bvh_box part = lo > l.at[0] ? rung(&l, lo) : low;
    int32_t open = -(int32_t)(l.at[1] >= lo);
    for (int32_t k = first; k < end; k++) {
        const float plane = s->planes[axis][k + 1];
        const rti_bvh_box above = rung(&l, plane);
        const int32_t now = open & -(int32_t)(l.at[1] <= plane);
        rti_bvh_extend(&part, above);
        add_middle(&part, &l, rti_i4_set(now));
        open &= ~now;
        put_part(part, box, &bins[k]);
        part = above;
    }
    rti_bvh_extend(&part, hi < l.at[2] ? rung(&l, hi) : high);
    add_middle(&part, &l, rti_i4_set(open & -(int32_t)(l.at[1] <= hi)));
    put_part(part, box, &bins[end]);
}

/* Whether a triangle's box is sliced in its place, which takes far less time: where it goes on for a few bins along the axis, or
 * is thin across. What the parts are too large by is then small, too. spans: bins that it goes on for, along the axis first. */
static inline bool slices_box(const rti_bvh_split *s, const int32_t spans[3])
{
    const int32_t some = (int32_t)s->space_bins / 4, few = (int32_t)s->space_bins / 8;
    return spans[0] <= some || (spans[1] <= few && spans[2] <= few);
}

static void space_clear(rti_bvh_space_bins *bins)
{
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t k = 0; k < RTI_BVH_BINS; k++) {
            bins->box[a][k] = rti_bvh_nothing();
            bins->enter[a][k] = bins->leave[a][k] = 0;
        }
}

static inline void space_put(const rti_bvh *t, const rti_bvh_split *s, const rti_ref *ref, float last, rti_bvh_space_bins *bins)
{
    const rti_bvh_box box = rti_bvh_ref_box(ref);
    int32_t first[4], end[4], spans[5]; /* of x, y, z, x, y */
    bins_of(s, box.lo, last, first);
    bins_of(s, box.hi, last, end);
    for (uint32_t a = 0; a < 3; a++)
        spans[a] = end[a] - first[a];
    spans[3] = spans[0];
    spans[4] = spans[1];
    for (uint32_t a = 0; a < 3; a++) {
        bins->enter[a][first[a]]++;
        bins->leave[a][end[a]]++;
        if (spans[a] == 0)
            rti_bvh_extend(&bins->box[a][first[a]], box);
        else if (slices_box(s, spans + a) || ref->prim >= t->b->in->tri_count)
            slice_box(s, box, a, first[a], end[a], bins->box[a]);
        else
            slice_triangle(s, &t->b->in->tris[ref->prim], ref, a, first[a], end[a], bins->box[a]);
    }
}

#define AHEAD 8u

void rti_bvh_spatial_bin(const rti_bvh *t, const rti_bvh_split *s, const rti_ref *refs, uint32_t count, rti_bvh_space_bins *bins)
{
    const float last = (float)(s->space_bins - 1);
    space_clear(bins);
    for (uint32_t i = 0; i < count; i++) {
        if (i + AHEAD < count && refs[i + AHEAD].prim < t->b->in->tri_count) /* triangles stand anywhere */
            __builtin_prefetch(&t->b->in->tris[refs[i + AHEAD].prim]);
        space_put(t, s, &refs[i], last, bins);
    }
}

void rti_bvh_space_bins_add(rti_bvh_space_bins *to, const rti_bvh_space_bins *from)
{
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t k = 0; k < RTI_BVH_BINS; k++) {
            rti_bvh_extend(&to->box[a][k], from->box[a][k]);
            to->enter[a][k] += from->enter[a][k];
            to->leave[a][k] += from->leave[a][k];
        }
}

static void find_on_axis(const rti_bvh *t, const rti_bvh_space_bins *bins, uint32_t a, uint32_t room, rti_bvh_split *s)
{
    rti_bvh_box right[RTI_BVH_BINS + 1], left = rti_bvh_nothing();
    uint32_t right_count[RTI_BVH_BINS + 1], left_count = 0;
    right[s->space_bins] = rti_bvh_nothing();
    right_count[s->space_bins] = 0;
    for (uint32_t k = s->space_bins; k-- > 1;) {
        right[k] = right[k + 1];
        rti_bvh_extend(&right[k], bins->box[a][k]);
        right_count[k] = right_count[k + 1] + bins->leave[a][k];
    }
    for (uint32_t k = 1; k < s->space_bins; k++) {
        float cost;
        rti_bvh_extend(&left, bins->box[a][k - 1]);
        left_count += bins->enter[a][k - 1];
        if (left_count == 0 || right_count[k] == 0 || left_count + right_count[k] > room)
            continue;
        cost = rti_bvh_area(t, left) * rti_bvh_leaf_cost(t, left_count) +
               rti_bvh_area(t, right[k]) * rti_bvh_leaf_cost(t, right_count[k]);
        if (cost < s->cost) {
            s->spatial = true;
            s->cost = cost;
            s->axis = a;
            s->bin = k;
            s->left_count = left_count;
            s->right_count = right_count[k];
        }
    }
}

void rti_bvh_spatial_find(const rti_bvh *t, const rti_bvh_space_bins *bins, uint32_t room, rti_bvh_split *s)
{
    float scale[4];
    rti_f4_store(scale, s->space_scale);
    for (uint32_t a = 0; a < 3; a++)
        if (scale[a] > 0.0f)
            find_on_axis(t, bins, a, room, s);
}

void rti_bvh_spatial_counts(const rti_bvh_split *s, const rti_bvh_space_bins *bins, uint32_t *left, uint32_t *right)
{
    *left = *right = 0;
    for (uint32_t k = 0; k < RTI_BVH_BINS; k++) {
        *left += k < s->bin ? bins->enter[s->axis][k] : 0;
        *right += k < s->bin ? 0 : bins->leave[s->axis][k];
    }
}

static void put(rti_ref *to, rti_bvh_box box, uint32_t prim, rti_bvh_box *boxes, rti_bvh_box *mids)
{
    rti_f4_store(to->lo, box.lo);
    rti_f4_store(to->hi, box.hi);
    to->prim = prim;
    to->pad = 0;
    rti_bvh_extend(boxes, box);
    add_point(mids, rti_bvh_mid(box));
}

void rti_bvh_spatial_scatter(const rti_bvh *t, const rti_bvh_split *s, const rti_ref *refs, uint32_t count, rti_ref *left,
                             rti_ref *right, rti_bvh_box boxes[2], rti_bvh_box mids[2])
{
    float base[4], scale[4], last = (float)(s->space_bins - 1), pos;
    uint32_t a = s->axis;
    rti_f4_store(base, s->space_base);
    rti_f4_store(scale, s->space_scale);
    pos = s->planes[a][s->bin];
    for (uint32_t i = 0; i < count; i++) {
        rti_bvh_box box = rti_bvh_ref_box(&refs[i]), half[2];
        uint32_t first = (uint32_t)bin_of(refs[i].lo[a], base[a], scale[a], last);
        uint32_t end = (uint32_t)bin_of(refs[i].hi[a], base[a], scale[a], last);
        half[0] = half[1] = box;
        if (first < s->bin && end >= s->bin)
            cut(t, refs[i].prim, box, a, pos, half);
        if (first < s->bin)
            put(left++, half[0], refs[i].prim, &boxes[0], &mids[0]);
        if (end >= s->bin)
            put(--right, half[1], refs[i].prim, &boxes[1], &mids[1]);
    }
}
