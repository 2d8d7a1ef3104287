/* The gait turns by TURN a cycle about the vertical, and its laws are those of axes that turn with it. */
#define TURN @TURN@
static const int TURNS[SWITCHES] = {@TURNS@};

static void about_vertical(double angle, double *vector) {
  double c = cos(angle), s = sin(angle), x = vector[0], y = vector[1];
  vector[0] = c * x - s * y;
  vector[1] = s * x + c * y;
}

/* Turn coordinates and rates: R = Rx(roll) Ry(pitch) Rz(yaw) by its first row and its third column, the angular
 * velocity x roll' + Rx y pitch' + Rx Ry z yaw' as a vector. */
static void turn_state(double angle, double *q, double *qd) {
  double cr = cos(q[3]), sr = sin(q[3]), cp = cos(q[4]), sp = sin(q[4]), cy = cos(q[5]), sy = sin(q[5]);
  double first[3] = {cp * cy, sr * sp * cy + cr * sy, -cr * sp * cy + sr * sy};
  double second[3] = {-cp * sy, -sr * sp * sy + cr * cy, cr * sp * sy + sr * cy};
  double third[3] = {sp, -sr * cp, cr * cp};
  double omega[3] = {qd[3] + sp * qd[5], cr * qd[4] - sr * cp * qd[5], sr * qd[4] + cr * cp * qd[5]};
  about_vertical(angle, q);
  about_vertical(angle, qd);
  about_vertical(angle, first);
  about_vertical(angle, second);
  about_vertical(angle, third);
  about_vertical(angle, omega);
  q[3] = atan2(-third[1], third[2]);
  q[4] = asin(fmax(-1.0, fmin(1.0, third[0])));
  q[5] = atan2(-second[0], first[0]);
  cr = cos(q[3]);
  sr = sin(q[3]);
  qd[4] = cr * omega[1] + sr * omega[2];
  qd[5] = (cr * omega[2] - sr * omega[1]) / cos(q[4]);
  qd[3] = omega[0] - sin(q[4]) * qd[5];
}

