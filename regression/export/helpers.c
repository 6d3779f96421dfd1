enum { BLOCK = 8 }; /* points that are evaluated at once */
/* compiled for processors with FMA too, chosen when the program starts */
#define CLONES
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__has_attribute)
#if __has_attribute(target_clones)
#undef CLONES
#define CLONES __attribute__((target_clones("fma", "default")))
#endif
#endif
/* n is a constant where the functions are used, 1 or BLOCK; loops over points are vectorized, not unrolled */
#ifdef __GNUC__
#define INLINE static inline __attribute__((always_inline))
#define EACH_POINT _Pragma("GCC unroll 1") for (int p = 0; p < n; p++)
#else
#define INLINE static inline
#define EACH_POINT for (int p = 0; p < n; p++)
#endif
INLINE double at_least(double a, double b) { return b > a ? b : a; }
INLINE double at_most(double a, double b) { return b < a ? b : a; }
INLINE double larger(double a, double b) { return a > b || isnan(a) ? a : b; }
INLINE double smaller(double a, double b) { return a < b || isnan(a) ? a : b; }
INLINE double square(double a) { return a * a; }
INLINE double half_cube(double a) { return a * sqrt(a); }
INLINE double power(double a, double b) { return exp(b * log(a)); }
