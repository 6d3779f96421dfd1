CLONES static void NAME_one(const NAME_point *at, NAME_result *results) { block(1, at, results); }
CLONES static void NAME_many(const NAME_point *at, NAME_result *results) { block(BLOCK, at, results); }

NAME_result NAME(NUMBERS)
{
    const NAME_point point = {MEMBERS};
    NAME_result result;
    NAME_one(&point, &result);
    return result;
}

void NAME_points(int n, const NAME_point points[], NAME_result results[])
{
    int i = 0;
    for (; i + BLOCK <= n; i += BLOCK) NAME_many(points + i, results + i);
    for (; i < n; i++) NAME_one(points + i, results + i);
}
